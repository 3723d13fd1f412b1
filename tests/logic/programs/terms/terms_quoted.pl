% Quoted atoms, strings and accents.
'Hello World'. 0.4::'a b'('C d', 'it is'). 0.3::says(ann, "good day"). 0.2::naïve(é). 'lower'.
query('Hello World'). query('a b'(_, _)). query(says(_, _)). query(naïve(_)). query(lower).
% expect: 'Hello World' = 1
% expect: 'a b'('C d','it is') = 0.4
% expect: says(ann,"good day") = 0.3
% expect: naïve(é) = 0.2
% expect: lower = 1
