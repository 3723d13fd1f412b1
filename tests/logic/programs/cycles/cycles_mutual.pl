% Mutual recursion without support is false; with support it is not.
a :- b. b :- a. 0.2::c. b :- c.
d :- e. e :- d.
query(a). query(d).
% expect: a = 0.2
% expect: d = 0
