"""A run as one page of HTML that plays in any browser: no server, no network, nothing to install.

export                               the page from what is shown; its size, and frames left out to bound it
encoding                             arrays as text: quantised, differences, gzip, base64
page.html, page.css                  the page
data.js, camera.js, shaders.js,
scene.js, controls.js                what draws it, in WebGL 2
"""
