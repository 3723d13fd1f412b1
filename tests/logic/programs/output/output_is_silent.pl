% What a program writes is no part of its answers.
0.3::a.
b :- write(a), writeln('b c'), nl, writenl(d, e), debugprint(f), a.
:- write('loading'), nl.
query(b).
% expect: b = 0.3
