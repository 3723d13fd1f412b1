% Two causes of one effect: one explains the other away.
0.3::rain. 0.3::hose.
wet :- rain. wet :- hose.
evidence(wet). evidence(hose).
query(rain).
% expect: rain = 0.3
