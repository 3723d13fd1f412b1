% Choices that depend on choices: draws without replacement.
0.5::first(red); 0.5::first(blue).
0.25::second(red); 0.75::second(blue) :- first(red).
0.75::second(red); 0.25::second(blue) :- first(blue).
same :- first(C), second(C).
query(second(_)). query(same).
% expect: second(red) = 0.5
% expect: second(blue) = 0.5
% expect: same = 0.25
