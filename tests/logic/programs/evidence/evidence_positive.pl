% Diagnosis: what is seen speaks for its causes.
0.1::burglary. 0.2::earthquake.
0.9::alarm :- burglary. 0.4::alarm :- earthquake.
evidence(alarm).
query(burglary). query(earthquake).
% expect: burglary = 0.5577395577
% expect: earthquake = 0.5577395577
