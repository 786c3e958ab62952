from .picture import take_picture as take_picture
