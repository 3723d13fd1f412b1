% Evidence whose atoms a body finds.
0.3::on(lamp). 0.6::on(fan). 0.2::on(heater).
seen(lamp). seen(fan).
evidence(on(X), true) :- seen(X).
query(on(_)).
% expect: on(lamp) = 1
% expect: on(fan) = 1
% expect: on(heater) = 0.2
