"""What benchmarks/ and tests/accuracy share; needs Python 3 only."""
