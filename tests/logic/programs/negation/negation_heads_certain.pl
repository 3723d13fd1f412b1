% A certain negative head overrules.
works :- powered.
\+works :- broken.
0.9::powered. 0.25::broken.
query(works).
% expect: works = 0.675
