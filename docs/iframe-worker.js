/* Pages that are opened from a folder may not start a worker, which the search of the theme is. There its script runs in a hidden frame instead. */
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(address) {
      super()
      this.waiting = []
      const frame = document.createElement("iframe")
      frame.hidden = true
      const start = () => {
        document.body.append(frame)
        const inside = frame.contentWindow
        inside.importScripts = (...files) => files.reduce((before, file) => before.then(() => load(inside, file)), Promise.resolve())
        inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }))
        load(inside, address).then(() => {
          this.inside = inside
          for (const data of this.waiting) this.postMessage(data)
        })
      }
      const load = (inside, file) => new Promise((done, fail) => {
        const script = inside.document.createElement("script")
        script.src = new URL(file, location.href)
        script.onload = done
        script.onerror = () => fail(new Error(`${file} cannot be loaded`))
        inside.document.body.append(script)
      })
      if (document.body) start()
      else addEventListener("DOMContentLoaded", start)
    }
    postMessage(data) {
      if (this.inside) this.inside.dispatchEvent(new MessageEvent("message", { data }))
      else this.waiting.push(data)
    }
    terminate() {}
  }
}
