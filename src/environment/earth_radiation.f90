!> Sunlight reflected and heat emitted by the Earth, as a satellite receives them, after Knocke.
!>
!> CSR-TM-00-01 section 2.3.2.3; P. C. Knocke, J. C. Ries, B. D. Tapley, AIAA 88-4292, 1988; P. C.
!> Knocke, dissertation, The University of Texas at Austin, 1989. The part of the Earth that the
!> satellite sees is cut into a cap about the subsatellite point and rings around it. All segments
!> have the same projected, attenuated area A' = (solid angle of the segment at the satellite)/pi.
!> Albedo and emissivity are zonal harmonics of degree 2 with a yearly term, taken at the
!> segment's centre.
module gracecg_environment_earth_radiation
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, ASTRONOMICAL_UNIT, EARTH_RADIUS_EGM96
    use gracecg_base_error, only: error_t, fail, fail_out_of_range, fail_unknown_name
    use gracecg_base_text, only: integer_text
    use gracecg_environment_table_earth_radiation, only: REPORT_ALBEDO, REPORT_EMISSIVITY, KNOCKE_ALBEDO, &
        KNOCKE_EMISSIVITY, PERIOD_DAYS, EPOCH_JD, SOLAR_IRRADIANCE_1AU
    implicit none
    private
    public :: earth_radiation_t, earth_irradiance_t, new_earth_radiation, standard_rings
    public :: MAX_SEGMENTS, MAX_RINGS, EARTH_RADIATION_EPOCH_JD, DEFAULT_SOLAR_IRRADIANCE
    public :: EARTH_RADIATION_CONSTANTS, SEGMENT_CENTRES

    !> Names of the sets of constants
    character(20), parameter :: EARTH_RADIATION_CONSTANTS(3) = [character(20) :: 'report', 'knocke', &
                                                                'constant-emissivity']
    !> Names of the places of a ring's centres between its edges: half-way in the angle at the Earth's centre, the
    !> reading of CSR-TM-00-01 whose curves lie in its printed windows; or where the ring's solid angle is halved, which
    !> is the better sum: 19 segments are 0.6 % RMS off the integral over the visible cap, those of mid-angle 12 %
    character(16), parameter :: SEGMENT_CENTRES(2) = [character(16) :: 'mid-angle', 'half-solid-angle']
    integer, parameter :: MAX_SEGMENTS = 169    !! The cap and seven rings of 6, 12 ... 42
    !> Greatest number of rings
    integer, parameter :: MAX_RINGS = 16
    real(dp), parameter :: EARTH_RADIATION_EPOCH_JD = EPOCH_JD
    !! t0 of eqs. (2-13), (2-14) as a Julian date, UTC
    real(dp), parameter :: DEFAULT_SOLAR_IRRADIANCE = SOLAR_IRRADIANCE_1AU
    !! W/m^2 at 1 au; CSR-TM-00-01 gives no figure
    real(dp), parameter :: ABSORBED_TO_EMITTED = 0.25_dp
    !! M_B/E_s: a sphere absorbs over its cross-section and emits over its surface
    real(dp), parameter :: SUBSATELLITE_POINT(2) = [1.0_dp, 0.0_dp]
    !! Cosine and sine of the angle zero at the Earth's centre

    type :: earth_radiation_t
        !! The model's constants; built by new_earth_radiation
        real(dp) :: albedo(5) = REPORT_ALBEDO
        !! a0; c0, c1, c2 (constant, cosine, sine of the year); a2: CSR-TM-00-01 eqs. (2-11), (2-13)
        real(dp) :: emissivity(5) = REPORT_EMISSIVITY
        !! e0; k0, k1, k2; e2: CSR-TM-00-01 eqs. (2-12), (2-14)
        real(dp) :: solar_irradiance = DEFAULT_SOLAR_IRRADIANCE     !! E_s at 1 au, W/m^2
        logical :: centres_halve_area = .false.     !! Centres at half of a ring's solid angle, and not at mid-angle
        integer :: segment_count = 1                !! N, the cap included
        integer, private :: ring_count = 0
        integer, private :: last_segment(0:MAX_RINGS) = 1
        !! Number of the last segment of each ring; the cap is ring 0 and segment 1
        real(dp), private :: azimuth(2, MAX_SEGMENTS) = 0
        !! Cosine and sine of each segment's azimuth, from north towards east
    contains
        procedure :: irradiance_at  !! What the segments send to a place
    end type earth_radiation_t

    type :: earth_irradiance_t
        !! What the Earth's segments send to one place; only the first `count` entries count
        integer :: count    !! Number of segments that see the satellite
        real(dp) :: direction(3, MAX_SEGMENTS)
        !! Unit vectors from the segments' centres to the satellite, inertial axes
        real(dp) :: irradiance(MAX_SEGMENTS)    !! On a surface facing the segment, W/m^2
    end type earth_irradiance_t

contains

    !> Rings of 6, 12, 18, ... segments. Two rings (19 segments with the cap) are Knocke's own choice
    !> and the only number with which the Earth radiation curves of CSR-TM-00-01 Figures 5.2 and 5.3
    !> lie in their printed windows; what the 7 of its card `ERADP 1 7` counts is not stated.
    pure function standard_rings(ring_count) result(segments_per_ring)
        integer, intent(in) :: ring_count   !! 0 to MAX_RINGS
        integer :: segments_per_ring(ring_count)

        integer :: i

        segments_per_ring = [(6*i, i=1, ring_count)]
    end function standard_rings

    !> Builds the model. Fails when the name of the constants is not known, when a ring has no
    !> segment or there are too many, and when the irradiance is outside 1 to 10^4 W/m^2.
    subroutine new_earth_radiation(self, constants, segments_per_ring, solar_irradiance, error, centres)
        type(earth_radiation_t), intent(out) :: self
        character(*), intent(in) :: constants
        !! 'report': the cards of CSR-TM-00-01 section 5.2, k1 = -0.17;
        !! 'knocke': the same but for Knocke's own k1 = -0.07;
        !! 'constant-emissivity': the report's albedo with e = e0, which is what the curves of
        !! Figures 5.2 and 5.3 show: its emissivity cards of degree 1 and 2 had no effect there
        integer, intent(in) :: segments_per_ring(:)
        !! From the cap outwards, e.g. standard_rings(1); empty: the cap alone
        real(dp), intent(in) :: solar_irradiance    !! At 1 au, W/m^2, e.g. DEFAULT_SOLAR_IRRADIANCE
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: centres   !! One of SEGMENT_CENTRES; 'mid-angle' when absent

        call check_settings(segments_per_ring, solar_irradiance, error)
        if (allocated(error)) return
        if (present(centres)) then
            if (.not. any(SEGMENT_CENTRES == centres)) then
                call fail_unknown_name(error, 'place of the segments'' centres', centres, SEGMENT_CENTRES)
                return
            end if
            self%centres_halve_area = centres == 'half-solid-angle'
        end if
        call set_constants(self, constants, error)
        if (allocated(error)) return
        self%solar_irradiance = solar_irradiance
        call lay_out_segments(self, segments_per_ring)
    end subroutine new_earth_radiation

    subroutine check_settings(segments_per_ring, solar_irradiance, error)
        integer, intent(in) :: segments_per_ring(:)
        real(dp), intent(in) :: solar_irradiance
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LOW = 1.0_dp, HIGH = 1e4_dp

        if (.not. (solar_irradiance >= LOW .and. solar_irradiance <= HIGH)) then
            call fail_out_of_range(error, 'solar irradiance at 1 au', solar_irradiance, LOW, HIGH, &
                                   'W/m^2')
        else if (size(segments_per_ring) > MAX_RINGS) then
            call fail_out_of_range(error, 'number of rings of the Earth radiation model', &
                                   real(size(segments_per_ring), dp), 0.0_dp, real(MAX_RINGS, dp))
        else if (any(segments_per_ring < 1)) then
            call fail(error, 'segments per ring of the Earth radiation model: every ring needs '// &
                      'at least one segment, but one has '// &
                      integer_text(minval(segments_per_ring)))
        else if (any(segments_per_ring > MAX_SEGMENTS) .or. &
                 sum(segments_per_ring) + 1 > MAX_SEGMENTS) then
            call fail(error, 'segments per ring of the Earth radiation model: with the cap at '// &
                      'most '//integer_text(MAX_SEGMENTS)//' segments are allowed')
        end if
    end subroutine check_settings

    subroutine set_constants(self, constants, error)
        type(earth_radiation_t), intent(inout) :: self
        character(*), intent(in) :: constants
        type(error_t), allocatable, intent(out) :: error

        select case (constants)
        case ('report')
            self%albedo = REPORT_ALBEDO
            self%emissivity = REPORT_EMISSIVITY
        case ('knocke')
            self%albedo = KNOCKE_ALBEDO
            self%emissivity = KNOCKE_EMISSIVITY
        case ('constant-emissivity')
            self%albedo = REPORT_ALBEDO
            self%emissivity = [REPORT_EMISSIVITY(1), 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp]
        case default
            call fail_unknown_name(error, 'constants of the Earth radiation model', constants, &
                                   EARTH_RADIATION_CONSTANTS)
        end select
    end subroutine set_constants

    !> What depends on the number of segments alone.
    pure subroutine lay_out_segments(self, segments_per_ring)
        type(earth_radiation_t), intent(inout) :: self
        integer, intent(in) :: segments_per_ring(:)

        integer :: ring, j, segment
        real(dp) :: angle

        segment = 1
        do ring = 1, size(segments_per_ring)
            do j = 0, segments_per_ring(ring) - 1
                segment = segment + 1
                angle = TWO_PI*j/segments_per_ring(ring)
                self%azimuth(:, segment) = [cos(angle), sin(angle)]
            end do
            self%last_segment(ring) = segment
        end do
        self%ring_count = size(segments_per_ring)
        self%segment_count = segment
    end subroutine lay_out_segments

    !> The radiation that reaches a satellite, by segments: A' (tau a E_s cos(theta_s) + e M_B),
    !> the sum of CSR-TM-00-01 eq. (2-10) without the satellite's own factors. E_s is taken at the
    !> Sun's distance from the Earth and the Sun in one direction for the whole Earth; M_B = E_s/4.
    !> The loads on a satellite are sums over segments.
    pure subroutine irradiance_at(self, position, sun_position, days_since_epoch, radiation)
        class(earth_radiation_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        !! Satellite, above the Earth's surface; inertial axes, z along the Earth's axis, m
        real(dp), intent(in) :: sun_position(3)     !! Sun, same axes, m
        real(dp), intent(in) :: days_since_epoch    !! From EARTH_RADIATION_EPOCH_JD, days
        type(earth_irradiance_t), intent(out) :: radiation

        real(dp) :: radius, sun_distance, irradiance, distance
        real(dp) :: up(3), north(3), east(3), from_centre(3), per_north(3), per_east(3)
        real(dp) :: season(3), albedo(0:2), emissivity(0:2), sun_up, sun_north, sun_east, sine, cosine
        real(dp) :: inner_edge(2), outer_edge(2), centre(2)
        integer :: ring, segment, first

        radius = sqrt(dot_product(position, position))
        up = position/radius
        call horizontal_directions(up, north, east)
        sun_distance = sqrt(dot_product(sun_position, sun_position))
        sun_up = dot_product(sun_position, up)/sun_distance
        sun_north = dot_product(sun_position, north)/sun_distance
        sun_east = dot_product(sun_position, east)/sun_distance
        season = seasonal_terms(days_since_epoch)
        albedo = zonal_coefficients(self%albedo, season)
        emissivity = zonal_coefficients(self%emissivity, season)*ABSORBED_TO_EMITTED
        ! projected area times solar irradiance
        irradiance = 2*limb_depth(radius)/self%segment_count*self%solar_irradiance*(ASTRONOMICAL_UNIT/sun_distance)**2

        radiation%count = self%segment_count
        first = 1
        inner_edge = SUBSATELLITE_POINT
        do ring = 0, self%ring_count
            outer_edge = boundary(radius, real(self%last_segment(ring), dp), self%segment_count)
            centre = SUBSATELLITE_POINT
            if (ring > 0 .and. self%centres_halve_area) then
                centre = boundary(radius, (first - 1 + self%last_segment(ring))/2.0_dp, self%segment_count)
            else if (ring > 0) then
                centre = bisector(inner_edge, outer_edge)
            end if
            distance = sqrt((radius - EARTH_RADIUS_EGM96*centre(1))**2 + &
                            (EARTH_RADIUS_EGM96*centre(2))**2)
            ! A segment's centre lies outward = c up + s (cos A north + sin A east), in radii of the Earth
            from_centre = (radius - EARTH_RADIUS_EGM96*centre(1))/distance*up
            per_north = -EARTH_RADIUS_EGM96*centre(2)/distance*north
            per_east = -EARTH_RADIUS_EGM96*centre(2)/distance*east
            do segment = first, self%last_segment(ring)
                associate (cos_azimuth => self%azimuth(1, segment), sin_azimuth => self%azimuth(2, segment))
                    sine = centre(1)*up(3) + centre(2)*cos_azimuth*north(3)
                    cosine = centre(1)*sun_up + centre(2)*(cos_azimuth*sun_north + sin_azimuth*sun_east)
                    radiation%irradiance(segment) = irradiance*(zonal_value(albedo, sine)*max(0.0_dp, cosine) + &
                                                                zonal_value(emissivity, sine))
                    radiation%direction(:, segment) = from_centre + cos_azimuth*per_north + sin_azimuth*per_east
                end associate
            end do
            first = self%last_segment(ring) + 1
            inner_edge = outer_edge
        end do
    end subroutine irradiance_at

    !> 1 - cos(zeta_m), where zeta_m is the nadir angle of the limb, sin(zeta_m) = R/r_s.
    pure real(dp) function limb_depth(radius) result(depth)
        real(dp), intent(in) :: radius      !! Satellite's distance from the Earth's centre, m

        real(dp) :: sin_squared

        sin_squared = (EARTH_RADIUS_EGM96/radius)**2
        depth = sin_squared/(1 + sqrt(max(0.0_dp, 1 - sin_squared)))
    end function limb_depth

    !> Cosine and sine of the angle beta at the Earth's centre, from the subsatellite point to the
    !> boundary that has `inside` of all the segments inside it. All segments fill the same solid
    !> angle, so the boundary's nadir angle zeta follows from
    !> 1 - cos(zeta) = (inside/total) (1 - cos(zeta_m)); then beta = gamma - zeta with
    !> sin(gamma) = r_s sin(zeta)/R.
    pure function boundary(radius, inside, total) result(cos_sin_beta)
        real(dp), intent(in) :: radius          !! Satellite's distance from the Earth's centre, m
        real(dp), intent(in) :: inside          !! Number of segments, the cap included, or half of them
        integer, intent(in) :: total            !! Of all
        real(dp) :: cos_sin_beta(2)

        real(dp) :: depth, cos_zeta, sin_zeta, cos_gamma, sin_gamma

        if (.not. inside < total) then   ! the limb: gamma is a right angle
            cos_sin_beta = [EARTH_RADIUS_EGM96/radius, 1 - limb_depth(radius)]
            return
        end if
        depth = limb_depth(radius)*inside/total
        cos_zeta = 1 - depth
        sin_zeta = sqrt(depth*(2 - depth))
        sin_gamma = radius*sin_zeta/EARTH_RADIUS_EGM96
        cos_gamma = sqrt((1 - sin_gamma)*(1 + sin_gamma))
        cos_sin_beta = [cos_gamma*cos_zeta + sin_gamma*sin_zeta, &
                        sin_gamma*cos_zeta - cos_gamma*sin_zeta]
    end function boundary

    !> Cosine and sine of the angle half-way between two angles less than pi apart: the direction of
    !> the sum of their unit vectors.
    pure function bisector(first, second) result(middle)
        real(dp), intent(in) :: first(2), second(2)     !! Cosine and sine of the angles
        real(dp) :: middle(2)

        middle = first + second
        middle = middle/sqrt(middle(1)**2 + middle(2)**2)
    end function bisector

    !> North and east at a place; at a pole itself, where there is no north, any two.
    pure subroutine horizontal_directions(up, north, east)
        real(dp), intent(in) :: up(3)                   !! Unit vector, z the Earth's axis
        real(dp), intent(out) :: north(3), east(3)      !! Unit vectors

        real(dp) :: distance_from_axis

        distance_from_axis = sqrt(up(1)**2 + up(2)**2)
        if (distance_from_axis > tiny(1.0_dp)) then
            east = [-up(2), up(1), 0.0_dp]/distance_from_axis
        else
            east = [0.0_dp, 1.0_dp, 0.0_dp]
        end if
        north = [-up(3)*east(2), up(3)*east(1), distance_from_axis]
    end subroutine horizontal_directions

    !> 1, cos W(t-t0), sin W(t-t0) of CSR-TM-00-01 eqs. (2-13), (2-14).
    pure function seasonal_terms(days_since_epoch) result(terms)
        real(dp), intent(in) :: days_since_epoch
        real(dp) :: terms(3)

        real(dp) :: angle

        angle = TWO_PI*days_since_epoch/PERIOD_DAYS
        terms = [1.0_dp, cos(angle), sin(angle)]
    end function seasonal_terms

    !> The three zonal coefficients on a date, CSR-TM-00-01 eqs. (2-13), (2-14).
    pure function zonal_coefficients(constants, season) result(zonal)
        real(dp), intent(in) :: constants(5)
        !! Degree 0; degree 1: constant, cosine, sine of the year; degree 2
        real(dp), intent(in) :: season(3)       !! From seasonal_terms
        real(dp) :: zonal(0:2)

        zonal = [constants(1), dot_product(constants(2:4), season), constants(5)]
    end function zonal_coefficients

    !> Albedo or emissivity at a latitude, CSR-TM-00-01 eqs. (2-11), (2-12).
    pure real(dp) function zonal_value(zonal, sin_latitude) result(value)
        real(dp), intent(in) :: zonal(0:2)
        real(dp), intent(in) :: sin_latitude    !! Geocentric

        value = zonal(0) + zonal(1)*sin_latitude + zonal(2)*(3*sin_latitude**2 - 1)/2
    end function zonal_value
end module gracecg_environment_earth_radiation
