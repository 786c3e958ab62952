from .client import Traffic as Traffic
from .pty import PtyPort as PtyPort
from .tcp import TcpPort as TcpPort
