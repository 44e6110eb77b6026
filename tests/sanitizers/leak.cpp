// Drops the only pointer to an allocation.
int main() {
  int* volatile lost = new int[100];
  lost = nullptr;
  return lost != nullptr;
}
