!> What an offset is estimated from and what comes out: a source's angular acceleration, what is known only with a sigma, and
!> the solution.
module gracecg_level1_offset_solution
    use gracecg_base_kinds, only: dp
    use gracecg_estimation_belief_report, only: belief_report_t
    implicit none
    private
    public :: level1_solution_t, source_series_t, consider_t, sigma_of

    type :: source_series_t
        !! The angular acceleration of one span
        real(dp), allocatable :: acceleration(:, :)     !! rad/s^2; axis, sample
        real(dp), allocatable :: patterns(:, :)         !! Of angles that were differentiated: how their noise of 1 rad shows in
                                                        !! it, as independent numbers; sample, pattern; 1/s^2
        real(dp) :: noise(3) = 0                        !! Sigma of the angles about each axis, rad
    end type source_series_t

    type :: consider_t
        !! Something that is not estimated and is known with a sigma: how it changes the angular acceleration
        real(dp) :: sigma = 0    !! Of what is not estimated, in its unit
        integer :: span = 0                             !! Only this one changes; 0: all
        type(source_series_t), allocatable :: change(:) !! By span, for a change by 1
    end type consider_t

    type :: level1_solution_t
        !! An offset with what it rests on
        character(12) :: source = ''    !! Of the angular acceleration
        character(12) :: leakage = ''                   !! estimated, a priori or none
        real(dp) :: offset(3) = 0                       !! d, m, SRF
        real(dp) :: formal(3, 3) = 0                    !! Covariance by noise and leakage, m^2
        real(dp) :: covariance(3, 3) = 0                !! And by what is considered, m^2
        real(dp) :: leak(3, 3) = 0, leak_sigma(3, 3) = 0            !! L: axis, rod; m/s^2/mA
        real(dp) :: leak_rate(3, 3) = 0, leak_rate_sigma(3, 3) = 0  !! K, m/s^2/(mA/s)
        real(dp) :: sigma_alone(3) = 0                  !! Of d if no leakage is estimated, m
        real(dp) :: sigma_free(3) = 0                   !! If it is estimated without a-priori sigma, m; huge: cannot be
        real(dp) :: condition = 0                       !! Of the scaled normal matrix with leakage, without a-priori sigma
        character(160) :: weakest = ''                  !! Direction that the data determine least
        real(dp) :: rms(3) = 0                          !! Of residuals in the band (`optimal`: all frequencies), by sample, m/s^2
        integer :: samples = 0, spans = 0    !! That are used
        real(dp), allocatable :: span_offset(:, :)      !! By each span alone with the leakage of all, m
        real(dp), allocatable :: span_sigma(:, :)       !! m; negative: not determined
        real(dp), allocatable :: span_rms(:, :)         !! Likewise, of each span
        real(dp) :: chi_square = 0                      !! Of the spans about the combined offset
        integer :: degrees = 0                          !! Of freedom of it
        real(dp) :: whiteness = 0                       !! Mean squares of residuals in the lower half of the band over those in
                                                        !! the upper, of the axis where that, or its inverse, is largest
        type(source_series_t), allocatable :: series(:) !! The source's angular acceleration, by span
        type(belief_report_t), allocatable :: beliefs   !! What the samples say of the setup; of the source optimal alone
        integer :: flag = 2                             !! 0 good, 1 with care, 2 not to be used
        character(200) :: reason = ''                   !! Why not 0
    end type level1_solution_t

contains

    !> Standard deviations of the offset.
    pure function sigma_of(solution) result(sigma)
        type(level1_solution_t), intent(in) :: solution
        real(dp) :: sigma(3)                    !! m

        integer :: k

        sigma = sqrt([(solution%covariance(k, k), k=1, 3)])
    end function sigma_of
end module gracecg_level1_offset_solution
