% Collections of collections.
has(ann, 1). 0.5::has(ann, 2). has(bob, 3).
name(ann). name(bob).
groups(L) :- findall(N-I, (name(N), findall(X, has(N, X), I)), L).
query(groups(_)).
% expect: groups([bob-[3], ann-[1]]) = 0.5
% expect: groups([bob-[3], ann-[1, 2]]) = 0.5
