% findall/3 enumerates the lists that may come out.
0.4::p(1). 0.5::p(2). p(3).
all_of(L) :- findall(X, p(X), L).
count(N) :- findall(X, p(X), L), length(L, N).
query(all_of(_)). query(count(_)).
% expect: all_of([1, 2, 3]) = 0.2
% expect: all_of([2, 3]) = 0.3
% expect: all_of([1, 3]) = 0.2
% expect: all_of([3]) = 0.3
% expect: count(3) = 0.2
% expect: count(2) = 0.5
% expect: count(1) = 0.3
