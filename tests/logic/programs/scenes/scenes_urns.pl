% An urn is chosen, then balls are drawn with replacement.
0.5::urn(1); 0.5::urn(2).
share(1, 0.8). share(2, 0.3).
P::white(N); Q::black(N) :- draw(N), urn(U), share(U, P), Q is 1 - P.
draw(1). draw(2). draw(3).
evidence(white(1)). evidence(white(2)).
query(urn(1)). query(white(3)).
% expect: urn(1) = 0.8767123288
% expect: white(3) = 0.7383561644
