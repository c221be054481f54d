"""What a reader of body measures is compared with: sections of scans, a net on clouds."""
