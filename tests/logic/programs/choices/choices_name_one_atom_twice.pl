% The same atom twice in one disjunction.
0.3::hit; 0.4::hit.
query(hit).
% expect: hit = 0.7
