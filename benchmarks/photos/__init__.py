"""``plogic bench photos``: real photos in BOP's layout with posed objects, beside a SIFT and RANSAC peer."""
