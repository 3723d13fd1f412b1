% Comments of both kinds, blank lines, several clauses a line.
% a line
/* several
   lines, with a clause: 0.9::a. */
0.3::a. b :- a. % at the end of a line

/* in the middle */ query(a). query(/* of a term */ b).
% expect: a = 0.3
% expect: b = 0.3
