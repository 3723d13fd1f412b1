% A choice with a variable is a choice per call, when the call binds it.
0.3::awake(X).
query(awake(owl)). query(awake(bat)).
pair :- awake(owl), awake(bat).
query(pair).
% expect: awake(owl) = 0.3
% expect: awake(bat) = 0.3
% expect: pair = 0.09
