% Texts as authors may write them in rules.pl (§9.7), each after what it is an example of, and a goal to ask.

%% a constraint on types ? constraint(N)
constraint(two) :- object(X, t1), object(Y, t1), X \= Y.

%% softened ? constraint(two)
constraint(two) :- object(X, t1), object(Y, t2).
0.9::constraint_may_fail(two).

%% softened to nothing ? constraint(any)
constraint(any) :- present(_).
1.0::constraint_may_fail(any).

%% one that always holds ? present(X)
constraint(none) :- present(X), \+ present(X).

%% a quoted type ? object(X, T)
constraint(boxes) :- object(_, 'A Box'), object(_, t1).

%% a name with variables ? constraint(N)
constraint(too_near(X, Y)) :- near(X, Y, 0.4), X \= Y.
0.3::constraint_may_fail(too_near(_, _)).

%% one of several may fail ? constraint(pair(X, Y))
constraint(pair(X, Y)) :- object(X, t1), object(Y, t2).
0.5::constraint_may_fail(pair(h1, _)).

%% a name of a type ? constraint(at_most_one(T))
constraint(at_most_one(T)) :- object(X, T), object(Y, T), X @< Y.
0.2::constraint_may_fail(at_most_one('A Box')).

%% how far it may fail ? constraint(far(X))
constraint(far(X)) :- distance(X, D), D > 1, present(X).
P::constraint_may_fail(far(X)) :- distance(X, D), P is 1 / (D + 1).

%% a choice that nothing else depends on ? wet
0.1::wet.

%% a choice for each ? heavy(X)
0.3::heavy(X) :- object(X, _).

%% a choice that is observed ? wet
0.1::wet.
evidence(wet).

%% a choice that is observed to fail ? wet
0.1::wet.
evidence(\+ wet).

%% evidence with a value ? cold
0.1::wet.
0.4::cold.
evidence(wet, false).
evidence(cold, true).

%% evidence for a rule ? wet
0.2::wet.
slippery :- wet, present(_).
evidence(slippery).

%% evidence against a rule ? wet
0.2::wet.
slippery(X) :- wet, object(X, t1).
evidence(\+ slippery(_)).

%% evidence for something ? object(X, t2)
some :- object(_, t2).
evidence(some).

%% evidence on a hypothesis ? present(X)
evidence(\+ present(h1)).

%% evidence on a datum ? cause(a0, H, F)
evidence(\+ noise(a0)).

%% an annotated disjunction ? colour(C)
0.2::colour(red); 0.5::colour(blue); 0.3::colour(green).
constraint(red) :- colour(red), present(h1).

%% a disjunction for each ? colour(X, C)
0.2::colour(X, red); 0.6::colour(X, blue) :- object(X, _).
constraint(alike(X, Y)) :- colour(X, C), colour(Y, C), X \= Y.
0.4::constraint_may_fail(alike(X, Y)).

%% a disjunction with a rest ? state(S)
0.2::state(on); 0.3::state(off) :- present(h1).
constraint(off) :- state(off).

%% arithmetic ? score(X, S)
score(X, S) :- ev(X, V), S is V * 2 + 1.
constraint(low(X)) :- score(X, S), S < 0.2.

%% a constraint that is a choice ? constraint(k)
0.5::constraint(k) :- present(h1).

%% negation ? beside(X)
lone(X) :- present(X), \+ beside(X).
beside(X) :- present(X), present(Y), X \= Y.
constraint(a) :- lone(_).

%% negation of a choice ? bold(X)
0.4::shy(X) :- present(X).
bold(X) :- present(X), \+ shy(X).
constraint(b) :- bold(h1), bold(h2).

%% nobody there ? present(X)
constraint(empty) :- \+ present(_).

%% exactly one ? constraint(N)
constraint(two) :- present(X), present(Y), X \= Y.
constraint(none) :- \+ present(_).
0.01::constraint_may_fail(_).

%% at most two, counted ? constraint(many)
constraint(many) :- findall(X, present(X), L), length(L, N), N > 2.
0.3::constraint_may_fail(many).

%% left of ? left_of(X, Y)
constraint(order) :- object(X, t2), object(Y, t1), left_of(X, Y).

%% on ? constraint(N)
constraint(stacked(X)) :- on(X, Y), object(Y, 'A Box').
0.2::constraint_may_fail(stacked(_)).

%% above, by a rule that calls itself ? over(X, Y)
over(X, Y) :- above(X, Y).
over(X, Z) :- above(X, Y), over(Y, Z).
constraint(tall(X, Y)) :- over(X, Y), distance(Y, _).
0.5::constraint_may_fail(tall(_, _)).

%% connected, which comes back to itself ? linked(X, Y)
linked(X, Y) :- near(X, Y, 0.8).
linked(X, Z) :- linked(X, Y), near(Y, Z, 0.8).
constraint(linked) :- linked(h1, h2).
0.4::constraint_may_fail(linked).

%% in view ? in_view_of_camera(X)
constraint(unseen(X)) :- present(X), \+ in_view_of_camera(X).
0.6::constraint_may_fail(unseen(_)).

%% occlusion ? occludes(X, Y)
constraint(hidden(X)) :- occludes(Y, X), object(Y, t1).
0.7::constraint_may_fail(hidden(_)).

%% the four cases ? lacking(X)
lacking(X) :- case(X, F, c).
constraint(lacks(X)) :- lacking(X).
0.25::constraint_may_fail(lacks(_)).

%% noise ? noise(A)
constraint(noisy(A)) :- noise(A).
0.8::constraint_may_fail(noisy(_)).

%% causes ? honest(H)
owner(H) :- cause(_, H, _).
0.5::honest(H) :- owner(H).
constraint(thief(H)) :- owner(H), \+ honest(H).

%% support ? floats(X)
constraint(hovers) :- floats(X), object(X, t1).
resting :- rests_on(_, _).
0.5::constraint_may_fail(hovers).

%% dv and rank ? rare(F)
rare(F) :- dv(F, V), V > 0.9.
0.3::trusted(T) :- rank(T, _).
constraint(untrusted) :- object(_, box), \+ trusted(box).

%% what only the program can tell ? present(X)
constraint(k) :- possible(object(_, t1)), present(h1).
0.5::constraint_may_fail(k).

%% everything together ? lit
0.3::night.
0.6::lamp(X) :- object(X, t1), night.
lit :- lamp(_).
lit :- \+ night.
constraint(dark) :- \+ lit, present(_).
0.1::constraint_may_fail(dark).
constraint(glare(X)) :- lamp(X), \+ night.
0.5::rumour(t2); 0.5::rumour(t1).
true_rumour :- rumour(T), object(_, T).
evidence(true_rumour).
