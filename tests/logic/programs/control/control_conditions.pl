% If-then-else by a condition and its negation.
0.3::rain.
take(umbrella) :- rain.
take(hat) :- \+rain.
action(X) :- (rain, X = stay ; \+rain, X = go).
query(take(_)). query(action(_)).
% expect: take(umbrella) = 0.3
% expect: take(hat) = 0.7
% expect: action(stay) = 0.3
% expect: action(go) = 0.7
