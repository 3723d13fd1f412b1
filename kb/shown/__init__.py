"""What a knowledge base holds, for people and for programs, with cautions."""
