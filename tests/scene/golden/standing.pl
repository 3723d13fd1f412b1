% The possible worlds of one image. Reading: posterior. A world is an assignment of present/1.

% ==== (1) Σo: object types as feature clouds, and the hypotheses that are of them

object_type(box). type_opaque(box).
type_part(box/x, box). type_feature(box, x, corner).
type_part(box/y, box). type_feature(box, y, corner).

% Δh: of which type each hypothesis is, and for which instance it competes.
hypothesis(h1, box). instance(h1, g_h1).
hypothesis(h2, box). instance(h2, g_h2).
hypotheses([h1, h2]).
hypotheses_of(box, [h1, h2]).

% ==== (2) The measures of Σo, and what geometry computed: poses, visibility, matches, outlines
dv(apex, 0.9910714285714286).
dv(corner, 0.8571428571428572).
dv(other, 0.1517857142857143).
rank(box, 0.9).
prior(box, 0.3).
hit_rate(corner, 0.8).

at(h1, 0.0000, 0.0000, 5.0000). distance(h1, 5.0000).
at(h1/x, 0.0000, 0.0000, 5.0000). in_image(h1, x). in_lobe(h1, x). match(h1, x, a_h1).
at(h1/y, 0.0000, 0.0000, 5.0000). in_image(h1, y). in_lobe(h1, y).

at(h2, 0.0000, 0.0000, 5.0000). distance(h2, 5.0000).
at(h2/x, 0.0000, 0.0000, 5.0000). in_image(h2, x). in_lobe(h2, x). match(h2, x, a_h2).
at(h2/y, 0.0000, 0.0000, 5.0000). in_image(h2, y). in_lobe(h2, y).

% Γ: appearance, type.
datum(a_h1, l_junction).
datum(a_h2, l_junction).

% Space: the middles of bodies and their nearest places to the camera, metres, camera frame; then the gaps between two, and up.
body_middle(h1, 0.0000, 0.0000, 5.0000). body_nearest(h1, 5.0000).
body_middle(h2, 0.0000, 0.0000, 5.0000). body_nearest(h2, 5.0000).
body_gap(h1, h2, 0.0000).
% Support: the chance that a thing rests on something known; planes, their normal upwards and offset, m, camera frame (§9.9).
rests_chance(0.9). plane_prior(none, 0.05).
plane(s1, 0.0000, -0.8000, -0.6000, -1.2500). plane_prior(s1, 0.6).
plane(s2, 0.0000, -1.0000, 0.0000, -0.5000). plane_prior(s2, 0.3).
% Ways to stand: who, on what, with which stable pose; the chance of that, and what the pose says of it, log-odds.
way_to_stand(_, _, _, _, _) :- fail.
way_to_stand(h1, s1, 2, 0.9, 3.5).
way_to_stand(h2, s1, 0, 0.45, -8.0).
way_to_stand(h2, h1, 0, 0.45, 4.0).
% Who may rest on something unknown, level above a plane, and what the pose says of that where it is free, log-odds.
level(_, _, _) :- fail.
level(h2, s1, 1.5).
% The four cells of each hypothesis in each context, by feature type: E∧D, E∧¬D, ¬E∧¬D, ¬E∧D.
occluders(h1, []).
cells(h1, [], [row(own(0.5), 1, 1, 0, 0)]).
occluders(h2, []).
cells(h2, [], [row(own(0.5), 1, 1, 0, 0)]).

% ==== (3) The choices
% A feature drawn from Σo is of type F with P(dv(F)) = 1 - dv(F), over their sum, which is 1 (§5.1).
(1-Apex)/S::drawn(apex); (1-Corner)/S::drawn(corner); (1-Other)/S::drawn(other) :-
  dv(apex, Apex), dv(corner, Corner), dv(other, Other), S is (1-Apex) + (1-Corner) + (1-Other), S > 0.

% Rivals for one instance are one alternative: they share the prior of their type; else there is none.
P::present(h1) :-
  prior_share(box, 1, P).
P::present(h2) :-
  prior_share(box, 1, P).
% Each expected feature is detected with its hit rate.
P::hit(H, F) :- candidate(H, F), feature_rate(H, F, P).
% Each claimed appearance has one cause: densities over their sum (bounded, so that ProbLog can read them).
0.9996001599360256::chosen(a_h1, h1/x); 0.00039984006397441024::chosen(a_h1, noise).
0.9996001599360256::chosen(a_h2, h2/x); 0.00039984006397441024::chosen(a_h2, noise).
% A case is as likely as evidence tells, over the most that is told of any, in N steps that ProbLog can read.
P::told_fits(E, C, K) :- told(E, C, L), told_most(E, M), told_steps(E, N), between(1, N, K), P is exp((L - M) / N).

% Things stand on one of these planes, or nothing says where; what is left is another plane.
P0/T::support(s1); P1/T::support(s2); P2/T::support(none) :-
  plane_prior(s1, P0), plane_prior(s2, P1), plane_prior(none, P2), T is max(1, P0 + P1 + P2).
% The pose of what is absent may stand by chance, as if it were there.
by_chance(_) :- fail.
0.12::by_chance(h2).
% Who has a footing stands on that plane, or on another hypothesis, in a stable pose, or is free.
C1/T::footing(h1, s1, 2); F/T::footing(h1, free, none) :-
  has_footing(h1), support(s1), way_to_stand(h1, s1, 2, C1, _), rests_chance(Q), F is max(0, 1 - Q), T is max(1, F + C1).
F/T::footing(h1, free, none) :-
  has_footing(h1), other_plane(h1), rests_chance(Q), F is max(0, 1 - Q), T is max(1, F + 0).
C1/T::footing(h2, s1, 0); C2/T::footing(h2, h1, 0); F/T::footing(h2, free, none) :-
  has_footing(h2), support(s1), way_to_stand(h2, s1, 0, C1, _), way_to_stand(h2, h1, 0, C2, _), rests_chance(Q), F is max(0, 1 - Q), T is max(1, F + C1 + C2).
C1/T::footing(h2, h1, 0); F/T::footing(h2, free, none) :-
  has_footing(h2), other_plane(h2), way_to_stand(h2, h1, 0, C1, _), rests_chance(Q), F is max(0, 1 - Q), T is max(1, F + C1).

% ==== (4) Σc: constraints and definitions D1-D8, free of any object type
% Of these there is nothing here.
type_look(_, _, _, _) :- fail. facet(_, _) :- fail. face(_, _) :- fail. object_part(_) :- fail.
self_hidden(_, _) :- fail. behind_surface(_, _, _) :- fail. preferred(_, _, _) :- fail. overlap(_, _) :- fail.
rival_pair(_, _) :- fail. exclusive(_, _) :- fail. outline_relation(_, _, _) :- fail. outline_roc(_, _, _) :- fail.
part_relation(_, _, _) :- fail. part_roc(_, _, _) :- fail. up_direction(_, _, _) :- fail. inside_image(_) :- fail.
cut_by_image(_) :- fail. body_over(_, _) :- fail. body_on(_, _) :- fail. body_on_both(_, _, _) :- fail.
weighs(_) :- fail. open_foot(_, _, _) :- fail. body_rests(_, _) :- fail. said_roc(_, _, _, _) :- fail.
said_relation(_, _, _, _) :- fail. stands(_) :- fail. own_rate(_, _, _) :- fail.

% What is said of a hypothesis follows from its type (§2).
feature_of(H, F, K) :- hypothesis(H, T), type_feature(T, F, K).
part_of(X, Y) :- hypothesis(H, T), type_part(V, W), node_of(V, T, H, X), node_of(W, T, H, Y).
node_of(T, T, H, H).
node_of(T/P, T, H, H/P).
opaque_surface(H) :- hypothesis(H, T), type_opaque(T).

% §4.2: what bounds an object: its surface, the facets and faces of that, and the surfaces of its parts.
bounds(S, H) :- hypothesis(H, _), S = surface(H).
bounds(S, H) :- hypothesis(H, T), facet(T, Fs), S = facet(H, Fs).
bounds(S, H) :- hypothesis(H, T), face(T, Fs), S = face(H, Fs).
bounds(S, H) :- hypothesis(H, T), object_part(T/P), S = surface(H/P).

% A3: proper parts; belongs(X, H): node X is of the tree of hypothesis H.
proper_part(X, Y) :- part_of(X, Y).
proper_part(X, Y) :- part_of(X, Z), proper_part(Z, Y).
belongs(H, H) :- hypothesis(H, _).
belongs(H/X, H) :- part_of(H/X, _).

% §4.1: rivals never hide each other.
rival(X, Y) :- rival_pair(X, Y).
rival(X, Y) :- rival_pair(Y, X).

% D4, D7: what a hypothesis alone leads to expect, and what a present opaque object, no rival, hides.
own_host_hides(H, F) :- self_hidden(H, F), opaque(H).
candidate(H, F) :- in_image(H, F), in_lobe(H, F), \+ own_host_hides(H, F).
hidden(H, F) :- behind_surface(H, F, G), G \= H, opaque(G), \+ rival(H, G), present(G).
in_view(H, F) :- candidate(H, F), \+ hidden(H, F).
claims(H, F, A) :- match(H, F, A), present(H), in_view(H, F).

% D5, feature form: Y has a self-visible feature, and every one of them is behind X.
not_behind(Y, X) :- candidate(Y, F), \+ behind_surface(Y, F, X).
all_behind(Y, X) :- behind_surface(Y, F, X), candidate(Y, F), X \= Y, \+ not_behind(Y, X).

% D8: a feature is detected if the hypothesis' one matching gives it an appearance.
found(H, F) :- match(H, F, _), in_image(H, F).

% §5.4: ev from dv and the four cells.
ev_in(H, C, V) :- cells(H, C, Rows), cells_weighed(Rows, Good, Bad), Good + Bad > 0, V is (Good - Bad) / (Good + Bad).
cells_weighed([], 0.0, 0.0).
cells_weighed([row(F, A, C, B, D) | Rest], Good, Bad) :-
  cell_weight(F, V), cells_weighed(Rest, G, N), Good is G + V * (A + B), Bad is N + V * (C + D).
cell_weight(F, V) :- dv(F, V).
cell_weight(own(V), V).

% A context of H: those of its occluders that are present.
context(H, C) :- occluders(H, Gs), those_present(Gs, C).
those_present([], []).
those_present([G | Gs], [G | C]) :- present(G), those_present(Gs, C).
those_present([G | Gs], C) :- \+ present(G), those_present(Gs, C).

% What is possible but very improbable stays possible for ProbLog.
bounded_chance(X, X) :- X =< 0.0.
bounded_chance(X, X) :- X >= 1.0.
bounded_chance(X, P) :- X > 0.0, X < 1.0, P is min(max(X, 1e-08), 1 - 1e-08).

% The prior of a type is shared by the N rivals for one instance; a feature has the hit rate of its type, or its own.
prior_share(T, N, P) :- prior(T, Q), X is Q / N, bounded_chance(X, P).
feature_rate(H, F, P) :- own_rate(H, F, P).
feature_rate(H, F, P) :- feature_of(H, F, K), hit_rate(K, P).

% §8, posterior: an appearance has exactly one cause, and every expected feature that hits needs its appearance.
hitting(A, H, F) :- match(H, F, A), present(H), in_view(H, F), hit(H, F).
other_hit(A, H, F) :- match(G, E, A), G/E \= H/F, hitting(A, G, E).
any_hit(A) :- hitting(A, _, _).
explained(A) :- match(H, F, A), chosen(A, H/F), hitting(A, H, F), \+ other_hit(A, H, F).
explained(A) :- chosen(A, noise), \+ any_hit(A).
missed(H, F) :- present(H), in_view(H, F), hit(H, F).

% What evidence tells of a case, in log-odds L, makes it e^L as likely, over the most that is told of any, in N steps.
fits_told(E, C) :- told_steps(E, N), fits_in_steps(E, C, N).
fits_in_steps(_, _, 0).
fits_in_steps(E, C, N) :- N > 0, told_fits(E, C, N), M is N - 1, fits_in_steps(E, C, M).
told_most(E, L) :- told(E, _, L), \+ told_beyond(E, L).
told_beyond(E, L) :- told(E, _, M), M > L.
told_least(E, L) :- told(E, _, L), \+ told_below(E, L).
told_below(E, L) :- told(E, _, M), M < L.
told_steps(E, N) :- told_most(E, M), told_least(E, L), N is max(1, ceiling((M - L) / 15.0)).

% §9.9: a pose is as likely as its footing makes it: ρ = e^L where it stands on what is there, or is free and level above the plane; else 1.
stands_right(H) :- footing_case(H, C), fits_told(footing(H), C).
footing_case(H, free) :- hypothesis(H, _), \+ has_footing(H).
footing_case(H, free) :- has_footing(H), support(none).
footing_case(H, free) :- footing(H, free, _), \+ level_above_plane(H).
footing_case(H, level(S)) :- footing(H, free, _), support(S), level(H, S, _).
footing_case(H, way(S, R)) :- footing(H, S, R), S \= free, to_stand_on(S).
level_above_plane(H) :- support(S), level(H, S, _).
to_stand_on(S) :- support(S).
to_stand_on(X) :- present(X).
told(footing(H), free, 0.0) :- hypothesis(H, _).
told(footing(H), way(S, R), L) :- way_to_stand(H, S, R, _, L).
told(footing(H), level(S), L) :- level(H, S, L).

% A4: distinct maximal objects are discrete.
violated(shares_volume(X, Y)) :- overlap(X, Y), present(X), present(Y).

% §9.9: who has a footing is chosen a way to stand: what is present, and what is not, but whose pose stands by chance,
% for nothing is there that excludes it.
has_footing(H) :- present(H).
has_footing(H) :- by_chance(H), \+ present(H), \+ explained_away(H).
explained_away(H) :- overlap(H, X), present(X).
explained_away(H) :- overlap(X, H), present(X).
explained_away(H) :- exclusive(H, X), present(X).
explained_away(H) :- exclusive(X, H), present(X).

% §9.9: a hypothesis whose plane is none of those that it has ways to stand on.
other_plane(H) :- hypothesis(H, _), \+ support(none), \+ own_plane(H).
own_plane(H) :- way_to_stand(H, S, _, _, _), support(S).

% ---- The vocabulary of queries
% object(H, Type): H is present and is of the type.
object(H, T) :- hypothesis(H, T), present(H).
% number_of_objects(N): N hypotheses are present.
number_of_objects(N) :- hypotheses(Hs), counted(Hs, N).
counted([], 0).
counted([H | Hs], N) :- counted(Hs, M), one_more(H, M, N).
one_more(H, M, N) :- present(H), N is M + 1.
one_more(H, N, N) :- \+ present(H).
% number_of(Type, N): N hypotheses of the type are present.
number_of(T, N) :- hypotheses_of(T, Hs), counted(Hs, N).
% node(X): X is a node of the part-whole tree of a present hypothesis.
node(X) :- belongs(X, H), present(H).
% part(P, H): P is a direct or indirect part of the present hypothesis H.
part(P, H) :- hypothesis(H, _), pp(P, H).
% pp(X, Y): X is a proper part of Y (A3).
pp(X, Y) :- belongs(X, H), present(H), proper_part(X, Y).
% p(X, Y): X is a part of Y: the same, or a proper part.
p(X, X) :- node(X).
p(X, Y) :- pp(X, Y).
% o(X, Y): X and Y have a part in common.
o(X, Y) :- p(X, Y).
o(X, Y) :- pp(Y, X).
% dr(X, Y): X and Y are discrete: no part in common.
dr(X, Y) :- belongs(X, G), belongs(Y, H), G \= H, present(G), present(H).
dr(X, Y) :- belongs(X, H), belongs(Y, H), X \= Y, \+ proper_part(X, Y), \+ proper_part(Y, X), present(H).
% max_object(H): H is a present object that is part of no other (D3).
max_object(H) :- hypothesis(H, _), present(H).
% atom(X): X is a node without proper parts (D2); users write atom(X).
atom_node(X) :- node(X), \+ proper_part(_, X).
% feature(H, F, Type): F is a feature of the present hypothesis H, of the type.
feature(H, F, T) :- feature_of(H, F, T), present(H).
% expected(H, F): F of the present H should be seen: in the image, in a lobe, behind nothing opaque (D7).
expected(H, F) :- feature_of(H, F, _), present(H), in_view(H, F).
% detected(H, F): F of the present H is matched to an appearance (D8).
detected(H, F) :- feature_of(H, F, _), present(H), found(H, F).
% case(H, F, Case): F of the present H is in case a (E∧D), b (¬E∧¬D), c (E∧¬D) or d (¬E∧D) of §4.
case(H, F, a) :- in_image(H, F), present(H), in_view(H, F), found(H, F).
case(H, F, b) :- in_image(H, F), present(H), \+ in_view(H, F), \+ found(H, F).
case(H, F, c) :- in_image(H, F), present(H), in_view(H, F), \+ found(H, F).
case(H, F, d) :- in_image(H, F), present(H), \+ in_view(H, F), found(H, F).
% cause(A, H, F): appearance A is caused by F of H.
cause(A, H, F) :- match(H, F, A), chosen(A, H/F), hitting(A, H, F).
% noise(A): no feature of a present hypothesis causes appearance A.
noise(A) :- datum(A, _), \+ caused(A).
caused(A) :- cause(A, _, _).
% why(H, F, Cause): why F of the present H is not detected: it is `outside` the image, `turned_away`, `self_hidden`, `behind(G)`, or `missed` (case c); or detected and not expected: its appearance is `caused_by(G/E)`, or `noise`.
why(H, F, outside) :- feature_of(H, F, _), \+ in_image(H, F), present(H).
why(H, F, turned_away) :- case(H, F, b), \+ in_lobe(H, F).
why(H, F, self_hidden) :- case(H, F, b), own_host_hides(H, F).
why(H, F, behind(G)) :- case(H, F, b), behind(H/F, G), G \= H, opaque(G), \+ rival(H, G).
why(H, F, missed) :- case(H, F, c).
why(H, F, caused_by(G/E)) :- case(H, F, d), match(H, F, A), cause(A, G, E).
why(H, F, noise) :- case(H, F, d), match(H, F, A), noise(A).
% behind(Y, X): the line of sight to Y meets X first; Y is a feature H/F, or an object all of whose self-visible features are.
behind(H/F, G) :- behind_surface(H, F, G), present(H), present(G).
behind(H, G) :- hypothesis(H, _), hypothesis(G, _), all_behind(H, G), present(H), present(G).
% hides_all_features(X, Y): opaque X hides every self-visible feature of Y, and there is one (D5, feature form).
hides_all_features(X, Y) :- hypothesis(Y, _), behind(Y, X), opaque(X).
% roc(Relation, X, Y): the relation of X to Y is this one of ROC-20, by outlines and depth (§3.7); of opaque hypotheses X and Y exactly one holds; what is not opaque occludes nothing, and where ROC-20 has no name for that, none holds; also of parts that are objects.
roc(R, X, Y) :- outline_roc(R, X, Y), present(X), present(Y).
roc(R, X, Y) :- part_roc(R, X, Y), node(X), node(Y).
% occludes(X, Y): some part of X totally occludes some part of Y (§3.6).
occludes(X, Y) :- partially_occludes(X, Y).
occludes(X, Y) :- totally_occludes(X, Y).
occludes(X, Y) :- mutually_occludes(X, Y).
% totally_occludes(X, Y): X covers Y, in front everywhere (D5, by outlines).
totally_occludes(X, Y) :- outline_relation(totally_occludes, X, Y), present(X), present(Y).
totally_occludes(X, Y) :- part_relation(totally_occludes, X, Y), node(X), node(Y).
% partially_occludes(X, Y): X is in front of a part of Y (D6, by outlines).
partially_occludes(X, Y) :- outline_relation(partially_occludes, X, Y), present(X), present(Y).
partially_occludes(X, Y) :- part_relation(partially_occludes, X, Y), node(X), node(Y).
% mutually_occludes(X, Y): each is in front of a part of the other, or they coincide.
mutually_occludes(X, Y) :- outline_relation(mutually_occludes, X, Y), present(X), present(Y).
mutually_occludes(X, Y) :- part_relation(mutually_occludes, X, Y), node(X), node(Y).
% non_occludes(X, Y): neither is in front of a part of the other.
non_occludes(X, Y) :- outline_relation(non_occludes, X, Y), present(X), present(Y).
non_occludes(X, Y) :- part_relation(non_occludes, X, Y), node(X), node(Y).
% surface_of(S, X): S is the surface `surface(X)` of X, a present hypothesis or a part of it that is an object (§4.2).
surface_of(S, X) :- bounds(S, H), present(H), S = surface(X).
% surface_part(S, H): S is part of the surface of the present H: `facet(H, Features)`, `face(H, Features)`, or the surface of a part.
surface_part(S, H) :- bounds(S, H), S \= surface(H), present(H).
% opaque(X): X is opaque: a hypothesis, its surface, or a part of either (A5, A6).
opaque(H) :- opaque_surface(H).
opaque(H/P) :- bounds(surface(H/P), H), opaque_surface(H).
opaque(S) :- bounds(S, H), opaque_surface(H).
% evidence_roc(Relation, X, Y): the relation of X to Y by what is detected of both, not by their poses, is this one of ROC-20 (§8, last paragraph); where one pose is withheld, roc is this.
evidence_roc(R, X, Y) :- stands(S), said_roc(S, R, X, Y), present(X), present(Y).
% evidence_relation(Relation, X, Y): the same, of the four coarse relations.
evidence_relation(R, X, Y) :- stands(S), said_relation(S, R, X, Y), present(X), present(Y).
% ev(H, V): V is the explanatory value of the present H, given which of its occluders are present (§5.4, §5.5).
ev(H, V) :- hypothesis(H, _), present(H), context(H, C), ev_in(H, C, V).
% left_of(X, Y): X's middle is further left than Y's, along the camera's x axis.
left_of(X, Y) :- body_middle(X, A, _, _), body_middle(Y, B, _, _), A < B, present(X), present(Y).
% right_of(X, Y): Y is left of X.
right_of(X, Y) :- left_of(Y, X).
% nearer(X, Y): the nearest place of X's surface is nearer to the camera than that of Y's.
nearer(X, Y) :- body_nearest(X, A), body_nearest(Y, B), A < B, present(X), present(Y).
% farther(X, Y): Y is nearer than X.
farther(X, Y) :- nearer(Y, X).
% gap(X, Y, V): V is how many metres are between X's surface and Y's, 0 where they touch.
gap(X, Y, V) :- body_gap(X, Y, V), present(X), present(Y).
gap(X, Y, V) :- body_gap(Y, X, V), present(X), present(Y).
% near(X, Y, D): X's and Y's surfaces are at most D metres apart.
near(X, Y, D) :- gap(X, Y, V), V =< D.
% above(X, Y): X is over Y along some plumb line, and Y over X along none; without a known up, of nothing.
above(X, Y) :- body_over(X, Y), present(X), present(Y).
% below(X, Y): Y is above X.
below(X, Y) :- above(Y, X).
% on(X, Y): X is above Y, touches it, and is held up by Y, or by Y and one other present object.
on(X, Y) :- body_on(X, Y), present(X), present(Y).
on(X, Y) :- body_on_both(X, Y, Z), present(X), present(Y), present(Z).
on(X, Y) :- body_on_both(X, Z, Y), present(X), present(Y), present(Z).
% in_view_of_camera(X): X's outline lies wholly in the image, hidden or not.
in_view_of_camera(X) :- inside_image(X), present(X).
% partly_in_view_of_camera(X): X's outline lies partly in the image, and partly outside.
partly_in_view_of_camera(X) :- cut_by_image(X), present(X).
% support_plane(S): S is the plane that things rest on; where nobody said that they rest, of nothing.
support_plane(S) :- support(S), S \= none.
% stance(H, On, Face): the present H has its stable pose Face on On, which is a plane, or a hypothesis (present in the posterior reading), or `free`.
stance(H, On, Face) :- footing(H, On, Face), present(H).
% stands_on(H, S): the present H stands on the plane S, in one of its stable poses.
stands_on(H, S) :- stance(H, S, _), support_plane(S).
% rests_on(X, Y): X touches Y from above, or stands on it in one of its stable poses, Y being another hypothesis or `ground`, which is the plane too; where gravity is not said to hold, or up is unknown, and nobody said that things rest, of nothing.
rests_on(X, Y) :- body_rests_on(X, Y).
rests_on(X, Y) :- stance(X, Y, _), present(X), present(Y).
rests_on(X, ground) :- stands_on(X, _).
body_rests_on(X, Y) :- body_rests(X, Y), Y \= ground, present(X), present(Y).
body_rests_on(X, ground) :- body_rests(X, ground), present(X).
body_rests_on(X, ground) :- open_foot(X, _, _), present(X), \+ higher_up(X).
higher_up(X) :- open_foot(X, A, _), open_foot(Y, _, B), B < A, present(Y).
% held(X): X rests on something present, a plane or the ground.
held(X) :- rests_on(X, _).
% floats(X): gravity is said to hold, and nothing holds X.
floats(X) :- weighs(X), present(X), \+ held(X).
% free(H): things are said to rest, and the present H stands on nothing that is known.
free(H) :- stance(H, free, _).
free(H) :- stance(H, X, _), hypothesis(X, _), \+ present(X).

% ==== (5) Evidence: no violated constraint, Γ, and what is missing in Γ
evidence(explained(a_h1)).
evidence(explained(a_h2)).
evidence(\+ missed(h1, y)).
evidence(\+ missed(h2, y)).
evidence(stands_right(h1)).
evidence(stands_right(h2)).
