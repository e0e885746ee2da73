// A program that only carries the precompiled header of the tests.
int main() { return 0; }
