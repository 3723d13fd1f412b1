% Predicates that a library also has, defined by the program.
append([], L, L).
append([H|T], L, [H|R]) :- append(T, L, R).
member(X, [X|_]).
member(X, [_|T]) :- member(X, T).
0.5::pick(X) :- member(X, [1, 2]).
query(append(X, Y, [1, 2])). query(pick(_)).
% expect: append([],[1, 2],[1, 2]) = 1
% expect: append([1],[2],[1, 2]) = 1
% expect: append([1, 2],[],[1, 2]) = 1
% expect: pick(1) = 0.5
% expect: pick(2) = 0.5
