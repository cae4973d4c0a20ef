"""What a drawing shows: rows of the catalog as plain numbers, without a drawing library."""
