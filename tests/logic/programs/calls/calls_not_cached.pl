% call_nc/N and nocache/2.
:- nocache(p, 1).
0.3::p(1).
b :- call_nc(p, 1). c :- call_nc(p(1)).
query(b). query(c). query(p(1)).
% expect: b = 0.3
% expect: c = 0.3
% expect: p(1) = 0.3
