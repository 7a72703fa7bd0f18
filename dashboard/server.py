"""The web server of the page: loopback, one certain port, no foreign origins."""

import contextlib
import io
import logging
from urllib.parse import urlsplit

import viser
from viser.infra import WebsockClientConnection

from .config import DashboardConfig
from .port_holder import PortBusyError, holder, require_free

log = logging.getLogger(__name__)

LOCAL_NAMES = ("127.0.0.1", "localhost", "[::1]")
BRAND = (240, 120, 40)
PANEL_WIDTH = 430  # [px]


class PageServer(viser.ViserServer):
    """A viser server that never opens a public tunnel, whoever asks."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        log.warning("a browser asked to share the page publicly: refused")
        return None

    def stop(self) -> None:
        """Close the page; viser announces even that on standard output."""
        with contextlib.redirect_stdout(io.StringIO()):
            super().stop()

    @property
    def url(self) -> str:
        """Address of the page."""
        host = self.get_host()
        return f"http://{f'[{host}]' if ':' in host else host}:{self.get_port()}"


def open_server(config: DashboardConfig) -> PageServer:
    """Serve an empty page.

    Raises:
        PortBusyError: The port is taken. viser by itself would take the next one.
    """
    require_free(config.host, config.port)
    with contextlib.redirect_stdout(io.StringIO()):  # viser prints a banner of its own
        server = PageServer(host=config.host, port=config.port, verbose=False)
    if config.port not in (0, server.get_port()):
        server.stop()
        raise PortBusyError(f"port {config.port} was taken meanwhile by {holder(config.port)}")
    _refuse_foreign_origins(server, set(config.trusted_origins))
    _furnish(server)
    return server


def is_local(origin: str | None, port: int) -> bool:
    """Whether a websocket was opened by a page of this server, or not by a browser at all."""
    return origin is None or origin in {f"http://{name}:{port}" for name in LOCAL_NAMES}


def _refuse_foreign_origins(server: PageServer, trusted: set[str]) -> None:
    """Without this, any web site that the user visits could push and stop the robot."""
    sockets = server._websock_server

    async def check(client: WebsockClientConnection) -> None:
        connection = sockets._live_connections[client.client_id]
        origin = connection.request.headers.get("Origin") if connection.request else None
        if not is_local(origin, server.get_port()) and origin not in trusted:
            log.warning("refused a page of %s", urlsplit(origin or "").netloc)
            await connection.close(1008, "foreign origin")

    sockets.on_client_connect(check)


def _furnish(server: PageServer) -> None:
    server.gui.configure_theme(
        dark_mode=True, show_logo=False, show_share_button=False, brand_color=BRAND
    )
    server.gui.set_panel_label("Wrenchbus")
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(PANEL_WIDTH)
    _light(server.scene)
    server.scene.set_up_direction("+z")
    server.scene.add_grid(
        "/floor",
        width=4.0,
        height=4.0,
        cell_size=0.1,
        section_size=0.5,
        cell_color=(60, 64, 70),
        section_color=(95, 100, 108),
    )


def _light(scene: viser.SceneApi) -> None:
    """Without shadows and reflections, which a browser that draws in software cannot afford."""
    scene.configure_default_lights(cast_shadow=False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light", sky_color=(255, 250, 244), ground_color=(120, 130, 150), intensity=1.2
    )
