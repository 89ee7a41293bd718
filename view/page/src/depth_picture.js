// The scanner's picture, in a corner; a tap enlarges it.

export class DepthPicture {
  constructor(button) {
    this.button = button;
    this.image = button.querySelector('img');
    this.count = 0;
    this.waiting = null;  // the newest picture, while the last one is being decoded
    this.isBusy = false;
    button.addEventListener('click', () => {
      button.setAttribute('aria-expanded', String(button.getAttribute('aria-expanded') !== 'true'));
    });
  }

  /// Hides the picture until the next one comes.
  clear() {
    this.waiting = null;
    this.button.hidden = true;
  }

  show(jpeg) {
    this.waiting = jpeg;
    if (!this.isBusy) { this.next(); }
  }

  async next() {
    this.isBusy = true;
    while (this.waiting) {
      const address = URL.createObjectURL(new Blob([this.waiting], { type: 'image/jpeg' }));
      this.waiting = null;
      this.image.src = address;
      try {
        await this.image.decode();
        this.button.style.setProperty('--aspect', this.image.naturalWidth / this.image.naturalHeight);
        ++this.count;
        this.button.hidden = false;
      } catch {
        // An invalid picture is not shown; the next one may be valid.
      }
      URL.revokeObjectURL(address);
    }
    this.isBusy = false;
  }
}
