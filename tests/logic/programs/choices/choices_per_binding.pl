% One choice per binding of the body.
pupil(ann). pupil(bob).
0.5::grade(P, a); 0.3::grade(P, b); 0.2::grade(P, c) :- pupil(P).
same :- grade(ann, G), grade(bob, G).
query(grade(ann, _)). query(same).
% expect: grade(ann,a) = 0.5
% expect: grade(ann,b) = 0.3
% expect: grade(ann,c) = 0.2
% expect: same = 0.38
