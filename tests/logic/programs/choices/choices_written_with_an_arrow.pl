% The arrow <- in place of :-.
0.4::start.
0.5::left; 0.5::right <- start.
query(left). query(right).
% expect: left = 0.2
% expect: right = 0.2
