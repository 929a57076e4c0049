"""What people type: `fabkit build`, `inspect`, `design`, and how they are answered."""
