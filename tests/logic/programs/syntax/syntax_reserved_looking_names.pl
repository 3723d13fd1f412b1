% Names that only look special.
choice(a). body(1). 0.4::multi(x). 0.3::open(door). 0.2::read(book). consult(x, y). call_me(1). 0.6::evidence_of(a). query_of(1).
query(choice(_)). query(body(_)). query(multi(_)). query(open(_)). query(read(_)). query(consult(_, _)). query(evidence_of(_)). query(query_of(_)).
% expect: choice(a) = 1
% expect: body(1) = 1
% expect: multi(x) = 0.4
% expect: open(door) = 0.3
% expect: read(book) = 0.2
% expect: consult(x,y) = 1
% expect: evidence_of(a) = 0.6
% expect: query_of(1) = 1
