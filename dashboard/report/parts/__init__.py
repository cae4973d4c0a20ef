"""What the report says, a chapter a file: facts and words in, blocks of written text out."""
