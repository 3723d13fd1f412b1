% Mutual influence: smokers and their friends.
person(1). person(2). person(3).
0.3::stress(X) :- person(X).
0.2::influences(X, Y) :- person(X), person(Y), X \= Y.
smokes(X) :- stress(X).
smokes(X) :- friend(X, Y), influences(Y, X), smokes(Y).
friend(1, 2). friend(2, 1). friend(2, 3). friend(3, 1).
evidence(smokes(2)).
query(smokes(1)). query(smokes(3)).
% expect: smokes(1) = 0.5040705985
% expect: smokes(3) = 0.4431669878
