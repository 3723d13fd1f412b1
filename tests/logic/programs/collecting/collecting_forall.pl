% forall/2 over certain and uncertain goals.
item(1). item(2).
0.4::done(1). 0.5::done(2).
finished :- forall(item(X), done(X)).
idle :- forall(done(X), X > 5).
query(finished). query(idle).
% expect: finished = 0.2
% expect: idle = 0.3
