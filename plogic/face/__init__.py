"""What people meet: commands, the session, tables, pictures and pages."""
