// Images of cameras: of each, the last one that was taken until the time of the player.

const LATER = 1e-9; // s: times of images and of frames differ by round-off

class Images {
  constructor(cameras) {
    this.cameras = cameras.map(({ name, time, images }) => {
      const home = [...document.querySelectorAll("[data-camera]")].find(({ dataset }) => dataset.camera === name);
      return { time, images, image: home.querySelector("img"), taken: home.querySelector("output"), shown: -1 };
    });
  }

  show(t) {
    for (const camera of this.cameras) {
      const k = indexAt(camera.time, t + LATER);
      if (k === camera.shown) continue;
      camera.shown = k;
      camera.image.src = `data:image/png;base64,${camera.images[k]}`;
      camera.taken.textContent = `${camera.time[k].toFixed(3)} s`;
    }
  }
}
