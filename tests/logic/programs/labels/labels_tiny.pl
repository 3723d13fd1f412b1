% Probabilities near 0 and near 1.
0.00001::rare. 0.99999::common.
either :- rare. either :- \+common.
query(rare). query(either).
% expect: rare = 1e-05
% expect: either = 1.99999e-05
