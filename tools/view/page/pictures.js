// Pictures that the server sends: a header of 24 bytes in little-endian order, then a JPEG or PNG
// file.
const headerBytes = 24, codecPng = 2;

export function readPicture(buffer) {
  const view = new DataView(buffer);
  const isLossless = view.getUint8(1) === codecPng;
  return {
    isLossless,
    isThinned: view.getUint16(2, true) !== 0,
    frame: view.getUint32(4, true),
    request: view.getUint32(8, true),
    width: view.getUint16(12, true),
    height: view.getUint16(14, true),
    ms: view.getFloat32(16, true),
    spacing: view.getFloat32(20, true),
    blob: new Blob([new Uint8Array(buffer, headerBytes)], { type: isLossless ? "image/png" : "image/jpeg" }),
  };
}

export function decode(picture) {
  return createImageBitmap(picture.blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
}

/** Draws a decoded picture; one with fewer pixels is enlarged. */
export function drawPicture(canvas, bitmap, { isThinned, spacing, width, height }) {
  const pen = canvas.getContext("2d", { alpha: false });
  pen.imageSmoothingEnabled = false;
  // The last column and row of a thinned picture may reach beyond the canvas.
  const [across, down] = isThinned ? [bitmap.width * spacing / width, bitmap.height * spacing / height] : [1, 1];
  pen.drawImage(bitmap, 0, 0, across * canvas.width, down * canvas.height);
}

export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export function downloadJson(json, name) {
  download(new Blob([JSON.stringify(json, null, 2), "\n"], { type: "application/json" }), name);
}
