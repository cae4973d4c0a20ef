"""A fuzzer that knows the formats: cases by number, judged by what independent readers say, run in children with limits."""
