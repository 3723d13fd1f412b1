% Nested functors, numbers, strings and lists as arguments.
0.3::owns(ann, book(title("Emma"), pages(474))).
0.6::owns(bob, list([1, two, "three", 4.5])).
owns(cid, nothing).
query(owns(_, _)).
% expect: owns(ann,book(title("Emma"),pages(474))) = 0.3
% expect: owns(bob,list([1, two, "three", 4.5])) = 0.6
% expect: owns(cid,nothing) = 1
