"""The shaft in three dimensions: one page of its own, drawn by three.js in the browser."""
