"""What is seen of posed surfaces: rays, Behind, outlines, RCC-8 of images, ROC-20."""
