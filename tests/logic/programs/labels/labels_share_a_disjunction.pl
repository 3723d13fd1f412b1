% Labels with variables in an annotated disjunction.
split(0.7, 0.2).
P::up; Q::down :- split(P, Q).
query(up). query(down).
% expect: up = 0.7
% expect: down = 0.2
