% Probabilities 0 and 1, as integers and as floats.
0::never. 1::always. 0.0::hardly. 1.0::surely. 0.5::perhaps.
both :- always, perhaps.
none :- never, perhaps.
query(never). query(always). query(hardly). query(surely). query(both). query(none).
% expect: never = 0
% expect: always = 1
% expect: hardly = 0
% expect: surely = 1
% expect: both = 0.5
% expect: none = 0
