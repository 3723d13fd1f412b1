% evidence/2 with true and false.
0.1::flu. 0.3::cold.
fever :- flu. cough :- cold. cough :- flu.
evidence(cough, true). evidence(fever, false).
query(flu). query(cold).
% expect: flu = 0
% expect: cold = 1
