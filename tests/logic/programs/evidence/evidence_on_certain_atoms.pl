% Evidence that is certain anyway changes nothing.
a. 0.25::b.
evidence(a). evidence(\+c). c :- fail.
query(b).
% expect: b = 0.25
