% true, fail, false and once.
0.3::a(1). 0.4::a(2).
b :- true, a(1). c :- fail. d :- false. e :- c. e :- a(2).
f :- once(a(_)).
query(b). query(c). query(d). query(e). query(f).
% expect: b = 0.3
% expect: c = 0
% expect: d = 0
% expect: e = 0.4
% expect: f = 0.58
