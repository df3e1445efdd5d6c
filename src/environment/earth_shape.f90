!> The WGS-84 ellipsoid: geodetic latitude, longitude and height against Earth-fixed coordinates.
module gracecg_environment_earth_shape
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: WGS84_SEMI_MAJOR_AXIS, WGS84_FLATTENING
    implicit none
    private
    public :: earth_fixed_to_geodetic

    real(dp), parameter :: A = WGS84_SEMI_MAJOR_AXIS        !! m
    real(dp), parameter :: F = WGS84_FLATTENING
    real(dp), parameter :: B = A*(1 - F)                    !! Semi-minor axis, m
    real(dp), parameter :: E2 = F*(2 - F)                   !! First eccentricity squared
    real(dp), parameter :: EP2 = E2/(1 - E2)                !! Second eccentricity squared

contains

    !> Geodetic coordinates of a point by B. R. Bowring's formula (Survey Review 23 (1976) 323-327)
    !> from his better first parametric latitude (Survey Review 28 (1985) 202-206), applied twice:
    !> good to rounding from the surface to beyond the geostationary orbit. The height is the
    !> point's distance from the ellipsoid along the normal, which is regular at the poles and
    !> insensitive to the latitude's error. Not for points within 100 km of the Earth's centre. At a
    !> pole the longitude is 0.
    pure subroutine earth_fixed_to_geodetic(position, latitude, longitude, height)
        real(dp), intent(in) :: position(3)     !! Earth-fixed, m
        real(dp), intent(out) :: latitude       !! Geodetic, rad, -pi/2 to pi/2
        real(dp), intent(out) :: longitude      !! rad, positive east, -pi to pi
        real(dp), intent(out) :: height         !! Above the ellipsoid, m

        real(dp) :: from_axis, z, parametric(2), normal(2)  ! directions as [cosine, sine]

        from_axis = sqrt(position(1)**2 + position(2)**2)
        z = position(3)
        parametric = direction(A*from_axis, B*z*(1 + EP2*B/sqrt(from_axis**2 + z**2)))
        normal = along_normal(parametric)
        parametric = direction(normal(1), (1 - F)*normal(2))
        normal = along_normal(parametric)
        normal = direction(normal(1), normal(2))
        latitude = atan2(normal(2), normal(1))
        longitude = 0
        if (from_axis > 0) longitude = atan2(position(2), position(1))
        height = from_axis*normal(1) + z*normal(2) - A*sqrt(1 - E2*normal(2)**2)

    contains

        !> Bowring's formula: from the parametric latitude of the foot towards the geodetic one, in m.
        pure function along_normal(foot) result(u)
            real(dp), intent(in) :: foot(2)
            real(dp) :: u(2)

            u = [from_axis - E2*A*foot(1)**3, z + EP2*B*foot(2)**3]
        end function along_normal
    end subroutine earth_fixed_to_geodetic

    pure function direction(x, y) result(u)
        real(dp), intent(in) :: x, y
        real(dp) :: u(2)

        u = [x, y]/sqrt(x**2 + y**2)
    end function direction
end module gracecg_environment_earth_shape
