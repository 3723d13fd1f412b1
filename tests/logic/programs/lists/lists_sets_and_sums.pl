% Sets, sums, extremes, ranges.
:- use_module(library(lists)).
a(S) :- sum_list([1, 2, 3.5], S).
b(M) :- max_list([3, 9, 4], M). c(M) :- min_list([3, 9, 4], M).
d(L) :- numlist(2, 5, L).
e(L) :- union([1, 2], [2, 3], L). f(L) :- intersection([1, 2, 3], [2, 3, 4], L). g(L) :- subtract([1, 2, 3], [2], L).
h(L) :- list_to_set([b, a, b, c, a], L).
i :- subset([1, 3], [1, 2, 3]). j :- is_set([1, 2, 1]).
query(a(_)). query(b(_)). query(c(_)). query(d(_)). query(e(_)). query(f(_)). query(g(_)). query(h(_)). query(i). query(j).
% expect: a(6.5) = 1
% expect: b(9) = 1
% expect: c(3) = 1
% expect: d([2, 3, 4, 5]) = 1
% expect: e([1, 2, 3]) = 1
% expect: f([2, 3]) = 1
% expect: g([1, 3]) = 1
% expect: h([b, a, c]) = 1
% expect: i = 1
% expect: j = 0
