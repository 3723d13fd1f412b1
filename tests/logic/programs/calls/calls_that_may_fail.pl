% try_call/1 takes what is unknown as false.
0.3::a.
b :- try_call(a). c :- try_call(no_such_thing). d :- \+try_call(no_such_thing).
query(b). query(c). query(d).
% expect: b = 0.3
% expect: c = 0
% expect: d = 1
