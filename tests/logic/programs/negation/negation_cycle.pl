% A negation that depends on itself has no meaning.
0.5::coin.
shaves :- coin, \+shaves.
query(shaves).
% expect error: NegativeCycleError
