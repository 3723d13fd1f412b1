% A game show: is it worth changing the door?
1/3::prize(1); 1/3::prize(2); 1/3::prize(3).
chosen(1).
0.5::opened(A); 0.5::opened(B) :- prize(P), chosen(P), others(P, A, B).
opened(D) :- prize(P), chosen(C), P \= C, door(D), D \= P, D \= C.
door(1). door(2). door(3).
others(1, 2, 3). others(2, 1, 3). others(3, 1, 2).
stay :- chosen(C), prize(C).
change :- chosen(C), opened(O), door(D), D \= C, D \= O, prize(D).
evidence(opened(3)).
query(stay). query(change).
% expect: stay = 0.3333333333
% expect: change = 0.6666666667
