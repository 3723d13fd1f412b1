% Labels that are computed.
1/4::a. 2*0.3::b. 1-0.1::c. min(0.2, 0.9)::d. 0.5**2::e. exp(0)/2::f. sqrt(0.04)::g.
query(a). query(b). query(c). query(d). query(e). query(f). query(g).
% expect: a = 0.25
% expect: b = 0.6
% expect: c = 0.9
% expect: d = 0.2
% expect: e = 0.25
% expect: f = 0.5
% expect: g = 0.2
