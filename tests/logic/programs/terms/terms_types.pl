% Tests of types.
kind(atom, X) :- atom(X). kind(number, X) :- number(X). kind(integer, X) :- integer(X). kind(float, X) :- float(X).
kind(compound, X) :- compound(X). kind(list, X) :- is_list(X). kind(ground, X) :- ground(X). kind(callable, X) :- callable(X).
kind(var, X) :- var(X). kind(nonvar, X) :- nonvar(X). kind(atomic, X) :- atomic(X).
thing(a). thing(1). thing(1.5). thing("s"). thing(f(a)). thing([1, 2]).
query(kind(K, X)) :- thing(X).
a :- var(_), \+nonvar(_), \+ground(f(_)).
query(a).
% expect: kind(atom,a) = 1
% expect: kind(ground,a) = 1
% expect: kind(callable,a) = 1
% expect: kind(nonvar,a) = 1
% expect: kind(atomic,a) = 1
% expect: kind(number,1) = 1
% expect: kind(integer,1) = 1
% expect: kind(ground,1) = 1
% expect: kind(nonvar,1) = 1
% expect: kind(atomic,1) = 1
% expect: kind(number,1.5) = 1
% expect: kind(float,1.5) = 1
% expect: kind(ground,1.5) = 1
% expect: kind(nonvar,1.5) = 1
% expect: kind(atomic,1.5) = 1
% expect: kind(ground,"s") = 1
% expect: kind(nonvar,"s") = 1
% expect: kind(compound,f(a)) = 1
% expect: kind(ground,f(a)) = 1
% expect: kind(callable,f(a)) = 1
% expect: kind(nonvar,f(a)) = 1
% expect: kind(compound,[1, 2]) = 1
% expect: kind(list,[1, 2]) = 1
% expect: kind(ground,[1, 2]) = 1
% expect: kind(callable,[1, 2]) = 1
% expect: kind(nonvar,[1, 2]) = 1
% expect: a = 1
